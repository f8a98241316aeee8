<!DOCTYPE qgis PUBLIC "http://mrcc.com/qgis.dtd" "SYSTEM">
<qgis version="3.22.0" styleCategories="Symbology|Fields|MapTips">
 <renderer-v2 type="categorizedSymbol" symbollevels="0" forceraster="0" enableorderby="0" attr="CASE WHEN is_usable THEN flight ELSE 'unusable' END">
  <categories>
   <category symbol="0" render="true" type="string" value="unusable" label="not usable"/>
   <category symbol="1" render="true" type="string" value="high_flight" label="model of the high flight"/>
   <category symbol="2" render="true" type="string" value="low_flight" label="model of the low flight"/>
  </categories>
  <symbols>
   <symbol type="fill" name="0" alpha="1" clip_to_extent="1" force_rhr="0">
    <layer class="SimpleFill" enabled="1" locked="0" pass="0">
     <Option type="Map">
      <Option type="QString" name="style" value="no"/>
      <Option type="QString" name="outline_style" value="dash"/>
      <Option type="QString" name="outline_color" value="200,30,30,255"/>
      <Option type="QString" name="outline_width" value="0.26"/>
      <Option type="QString" name="outline_width_unit" value="MM"/>
     </Option>
     <prop k="style" v="no"/>
     <prop k="outline_style" v="dash"/>
     <prop k="outline_color" v="200,30,30,255"/>
     <prop k="outline_width" v="0.26"/>
     <prop k="outline_width_unit" v="MM"/>
    </layer>
   </symbol>
   <symbol type="fill" name="1" alpha="1" clip_to_extent="1" force_rhr="0">
    <layer class="SimpleFill" enabled="1" locked="0" pass="0">
     <Option type="Map">
      <Option type="QString" name="style" value="no"/>
      <Option type="QString" name="outline_style" value="solid"/>
      <Option type="QString" name="outline_color" value="90,90,90,255"/>
      <Option type="QString" name="outline_width" value="0.26"/>
      <Option type="QString" name="outline_width_unit" value="MM"/>
     </Option>
     <prop k="style" v="no"/>
     <prop k="outline_style" v="solid"/>
     <prop k="outline_color" v="90,90,90,255"/>
     <prop k="outline_width" v="0.26"/>
     <prop k="outline_width_unit" v="MM"/>
    </layer>
   </symbol>
   <symbol type="fill" name="2" alpha="1" clip_to_extent="1" force_rhr="0">
    <layer class="SimpleFill" enabled="1" locked="0" pass="0">
     <Option type="Map">
      <Option type="QString" name="style" value="no"/>
      <Option type="QString" name="outline_style" value="solid"/>
      <Option type="QString" name="outline_color" value="150,180,210,255"/>
      <Option type="QString" name="outline_width" value="0.26"/>
      <Option type="QString" name="outline_width_unit" value="MM"/>
     </Option>
     <prop k="style" v="no"/>
     <prop k="outline_style" v="solid"/>
     <prop k="outline_color" v="150,180,210,255"/>
     <prop k="outline_width" v="0.26"/>
     <prop k="outline_width_unit" v="MM"/>
    </layer>
   </symbol>
  </symbols>
 </renderer-v2>
 <blendMode>0</blendMode>
 <featureBlendMode>0</featureBlendMode>
</qgis>
